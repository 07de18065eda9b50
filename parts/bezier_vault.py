"""The paper's massive timber vault: planks along a discrete Bezier curve (figures 14 and 16).

Layers of raw sawn planks stand side by side and are screwed together; joints are staggered from
layer to layer. The shape is controlled by four control points, the subdivision by the longest board
and the smallest acceptable deviation from the smooth curve.
"""

import ifs_cad as ifs

if "show_object" not in globals():  # injected by CQGI and CQ-editor
    from ifs_cad import show_object

span = 6000.0
rise = 4000.0  # of the two upper control points
lean = 0.12  # how far they are moved sideways, as a share of the span
longest = 1000.0  # plank that the workshop can handle
deviation = 20.0  # of the planks' axes from the smooth curve
width = 150.0
thickness = 27.0
layers = 30
scale = 1.0  # 0.1 makes a model, of planks model_thickness mm thick
model_thickness = 4.0
screw = 6.0
screw_spacing = 350.0
engraving_depth = 0.5
cutter = 3.0
margin = 5.0  # of the labels, from sides and holes
nest = 1  # layers are sub-assemblies

curve = ifs.Curve(
    [
        (0, 0, 0),
        ((lean - 0.1) * span, 0, rise),
        ((lean + 0.95) * span, 0, 1.15 * rise),
        (span, 0, 0),
    ]
)
subdivision = ifs.iteration_depths(curve, longest=longest, deviation=deviation)
print(subdivision)

vault = ifs.vault(
    curve.with_depth(subdivision.depth),
    width,
    thickness,
    layers=layers,
    stagger=True,
    springing=ifs.Plane((0, 0, 0), (0, 0, 1)),
)
if scale != 1.0:
    vault = vault.scale(scale, model_thickness)
    screw, screw_spacing = scale * screw, scale * screw_spacing
    cutter, margin = scale * cutter, scale * margin
assembly = ifs.to_assembly(
    vault,
    label=ifs.Label(depth=engraving_depth, cutter=cutter, margin=margin),
    holes=ifs.Screws(screw, spacing=screw_spacing),
    nest=nest,
    name="vault",
)
show_object(assembly, name="vault")
