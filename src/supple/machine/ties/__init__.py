"""What ties the nodes of a part to another: where they meet, and what is equal there."""
