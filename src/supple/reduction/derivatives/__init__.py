"""Modal derivatives: computation, weights, selection and compression."""
