"""What joins nodes of an Abaqus file beside elements: links, ties, surfaces, hinges, springs."""
