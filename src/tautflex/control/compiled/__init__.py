"""The loop around a reduced model on its hub, compiled: drives, steps and sensors in one call."""
