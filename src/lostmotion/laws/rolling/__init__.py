"""Rolling bearings: contacts, load distribution, equilibrium and stiffness."""
