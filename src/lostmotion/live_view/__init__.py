"""The live view of an arm in the browser: scene and panel on a server of this computer."""
