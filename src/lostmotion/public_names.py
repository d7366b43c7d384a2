"""Every public name and its home, as `__init__.pyi` lists them."""

from __future__ import annotations

import pkgutil
import re
from typing import Final

# In reading order; functions whose home is a `command` are questions, which the command line
# asks as well. Their results may stand beside them.
HOMES: Final = {
    name: match[1]
    for match in re.finditer(
        r"^from (lostmotion\.\S+) import (.+)$",
        (pkgutil.get_data("lostmotion", "__init__.pyi") or b"").decode(),
        re.MULTILINE,
    )
    for name in re.findall(r"as (\w+)", match[2])
}
QUESTIONS: Final = {
    name: home for name, home in HOMES.items() if home.endswith(".command") and name.islower()
}
