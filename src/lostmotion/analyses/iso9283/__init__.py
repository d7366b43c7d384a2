"""ISO 9283:1998: characteristics by their definitions, predicted and measured; never 'certified'."""
