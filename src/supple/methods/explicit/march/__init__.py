"""The compiled explicit march: its model, its state, and the steps between."""
