"""Does it stand: from a shell to a finite element model of its panels, and what it answers.

Panels are flat shells of their own, joined along shared edges by hinges (the paper's assumption),
springs or rigidly. Element matrices come from Kratos, an optional library imported on first use.

Source: section 5 and figure 22.
"""
