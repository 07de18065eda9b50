"""Point weights on a smooth and on a rough surface, figure 13: before and after."""

import cadquery as cq

import ifs_cad as ifs

if "show_object" not in globals():  # injected by CQGI and CQ-editor
    from ifs_cad import show_object

depth = 4
apart = 4200.0

assembly = cq.Assembly(name="surfaces")
for row, roughness in enumerate((0.0, 0.5)):
    for column, weight in enumerate((1.0, 2.0)):
        a = ifs.Curve([(0, 0, 0), (1500, 0, 1600), (3000, 0, 0)], depth=depth)
        b = ifs.Curve([(0, 0, 0), (0, 1500, 800), (0, 3000, 0)], depth=depth)
        a = a.with_control_point(1, (1500, 0, 1600), weight=weight)
        surface = ifs.vector_sum(a, b.with_roughness(roughness))
        place = cq.Location((apart * column, -apart * row, 0))
        assembly.add(
            ifs.mesh_to_faces(surface),
            name=f"roughness{roughness:g}-weight{weight:g}",
            loc=place,
            color=cq.Color(0.87, 0.72, 0.5),
        )
show_object(assembly, name="surfaces")
