"""The world the controllers cannot see into: physics engine, soles, motors, stops, sensors."""
