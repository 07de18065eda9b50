"""The paper's second prototype: 256 different plywood panels that span 4.5 m (figure 21).

A smooth arch in the long section, a folded, rough curve in the cross section; 10 mm spruce
plywood, standing flat on the floor, every panel engraved with its address and pierced for the
screws that hold it on the machine's table.
"""

import ifs_cad as ifs

if "show_object" not in globals():  # injected by CQGI and CQ-editor
    from ifs_cad import show_object

span = 4500.0
width = 3000.0
rise = 2150.0
fold_slope = 0.85  # rise over run of every fold; the steeper, the stiffer
roughness = 0.25
depth = 4
thickness = 10.0
clearance = 0.0  # how far each chamfer is set back; 0.1 eases the assembly
foot_allowance = 60.0  # how far the feet reach below the floor, which trims them
engraving_depth = 0.5
cutter = 3.0
hole_diameter = 5.0
hole_inset = 25.0
nest = 1  # digits of the address that group panels into sub-assemblies

base = ifs.Curve(
    [(0, 0, 0), (0, 0.55 * width, 0.1 * width), (0, width, -0.02 * width)], depth=depth - 1
)
fold = base.with_roughness(roughness).with_even_fold(fold_slope)
foot = -fold.points[:, 2].max() - foot_allowance
arch = ifs.Curve(
    [(0, 0, foot), (-0.05 * span, 0, 1.22 * rise), (0.95 * span, 0, 1.36 * rise), (span, 0, foot)],
    depth=depth,
)

surface = ifs.vector_sum(arch, fold)
shell = ifs.thicken(
    surface,
    thickness,
    side="outer",
    clearance=clearance,
    floor=ifs.Plane((0, 0, 0), (0, 0, 1)),
).with_fibre(ifs.FibreAlongCurve("a"))
assembly = ifs.to_assembly(
    shell,
    label=ifs.Label(face="inner", depth=engraving_depth, cutter=cutter),
    holes=ifs.Holes(hole_diameter, hole_inset),
    nest=nest,
    name="shell",
)
show_object(assembly, name="shell")
