"""The quadruple pendulum and the slider-crank of [Han2020], reduced to tolerances."""
