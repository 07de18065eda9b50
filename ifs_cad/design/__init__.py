"""What the designer draws: schemes, curves, surfaces, meshes; no CAD kernel in this room."""
