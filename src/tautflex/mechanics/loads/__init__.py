"""What acts on the structure in time: effects (what one unit does, one a file), signals (how much, when), pressure."""
