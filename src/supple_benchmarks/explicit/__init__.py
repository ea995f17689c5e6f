"""Explicit combined modal reduction: accuracy and cost, measured."""
