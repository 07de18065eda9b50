"""Drawings of sheets, boards, elements and the assembly, as pages of lines and text."""
