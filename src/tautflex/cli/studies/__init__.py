"""Commands on many runs: a case at many values of its keys, and the best of them."""
