"""References independent of our elements: closed forms and geometrically exact beams."""
