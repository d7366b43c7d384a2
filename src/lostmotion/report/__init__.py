"""Pages that need nothing else, and the folders they are written into; `page` and `folder` for any sheet, one file each for what it is about."""
