"""Closing the loop: linear view of a plant, sensors and laws [control.md]."""
