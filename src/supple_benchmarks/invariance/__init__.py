"""How much a body's answer depends on its frame, its ties and its basis, beside references that do not."""
