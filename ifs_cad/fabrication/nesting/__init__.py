"""What lies where: workpieces on sheets."""
