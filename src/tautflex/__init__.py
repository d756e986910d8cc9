"""tautflex: nonlinear dynamics of tensioned membrane antennas on maneuvering spacecraft.

Names are loaded when first used, so that importing the package costs nothing; ``__init__.pyi`` lists them.

Examples
--------
>>> import tautflex as tf
>>> case = tf.load_case("m2.toml")                       # tautflex init m2.toml --template m2-nearest-node
>>> state = tf.solve_prestress(tf.build_model(case))
>>> tf.solve_modes(state, n=3).labels[0]
(1, 1)
"""

from tautflex.public import public_names

__getattr__, __dir__, __all__ = public_names(__name__, __file__)
