"""Full-order engine for bodies with all finite-element freedoms: sparse Newton steps."""
