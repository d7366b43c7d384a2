"""The view in the browser: scene and panel on a server of this computer."""
