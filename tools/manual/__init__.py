"""Builds parts of the manual: pages of public names and commands, figures of examples, a look at all links."""
