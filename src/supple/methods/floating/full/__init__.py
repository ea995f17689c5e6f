"""The engine for bodies with all their freedoms: sparse Newton steps."""
