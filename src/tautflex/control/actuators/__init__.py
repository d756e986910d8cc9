"""Actuators: what a plant is commanded by, an effect behind a drive."""
