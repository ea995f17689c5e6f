"""Mass and stiffness matrices in the formats other programs write."""
