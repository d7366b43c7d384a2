"""The chain of an arm: places, frames, loads, statics and inverse kinematics."""
