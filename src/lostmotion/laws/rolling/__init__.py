"""Rolling bearings: contact laws and the equilibrium of the shaft."""
