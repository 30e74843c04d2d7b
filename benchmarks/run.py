"""Run every benchmark of this folder, each in a process of its own."""

import subprocess
import sys
from pathlib import Path

HERE = Path(__file__)

for script in sorted(HERE.parent.glob("*.py")):
    if script.name not in (HERE.name, "irsim_peer.py", "rows.py"):
        print(f"== {script.stem}", flush=True)
        subprocess.run([sys.executable, str(script)], check=True)
