"""What a run leaves so that another one goes on."""
