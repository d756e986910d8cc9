"""Studies: one case at many values of its keys, on one machine or on many; what is finished is kept."""
