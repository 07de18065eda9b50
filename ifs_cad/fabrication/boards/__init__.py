"""Which planks are cut from which boards."""
