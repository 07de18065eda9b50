"""How elements are cut: stock, boards, nesting, operations."""
