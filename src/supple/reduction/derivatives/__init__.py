"""Modal derivatives: computed, weighted, picked or compressed."""
