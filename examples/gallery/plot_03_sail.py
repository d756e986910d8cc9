"""
A triangular solar sail
=======================

Film, edge cords and three booms come from an Abaqus file; sunlight pushes the film while the sail turns by 20 degrees.
"""

import tempfile
from pathlib import Path

import tautflex as tf
from tautflex.case import template, template_files

# What `tautflex init sail.toml --template sail` writes.
folder = Path(tempfile.mkdtemp())
for name, text in {"sail.toml": template("sail"), **template_files("sail")}.items():
    (folder / name).write_text(text, encoding="utf-8")
case = tf.load_case(folder / "sail.toml").replaced(solver={"time_step": 0.04, "end_time": 30.0})
state = tf.solve_prestress(tf.build_model(case))
modes = tf.plot.plot_modes(tf.solve_modes(state, n=3))

# %%
# The booms clamped at the hub, the sun switched on at the start.
run = tf.run_case(case)
record = tf.plot.plot_time_history(run)
