"""What joins points of a Nastran deck beside elements: links, springs, moved and pinned ends of beams."""
