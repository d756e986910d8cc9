"""Pages that stand alone: results in a browser, without a network, with everything in one file."""
