"""How long a person waits before anything happens: import, help, demo (whole processes)."""

import subprocess
import sys
import tempfile
from pathlib import Path
from time import perf_counter

SONARBED = str(Path(sys.executable).with_name("sonarbed"))


def main() -> None:
    report("import sonarmap", [sys.executable, "-c", "import sonarmap"], 1.0)
    loaded = "import sonarmap, sys; sonarmap.AMIGOBOT; sys.exit('pybullet' in sys.modules)"
    subprocess.run([sys.executable, "-c", loaded], check=True)
    report("sonarbed --help", [SONARBED, "--help"], 0.5)
    with tempfile.TemporaryDirectory() as folder:
        report("sonarbed demo", [SONARBED, "demo", "--out", folder], 60.0, runs=2)


def report(name: str, command: list[str], target_s: float, runs: int = 5) -> None:
    subprocess.run(command, check=True, capture_output=True)  # byte code and kernels are cached
    seconds = []
    for _ in range(runs):
        begin = perf_counter()
        subprocess.run(command, check=True, capture_output=True)
        seconds.append(perf_counter() - begin)
    seconds.sort()
    print(f"{name}: {seconds[len(seconds) // 2]:.2f} s, median of {runs} (target {target_s:g} s)")


if __name__ == "__main__":
    main()
