"""Known vulnerabilities of the pinned versions, by pip-audit: `make audit`.

Status 1 where there are some.  A database that cannot be reached is told in one line.
"""

import json
import subprocess
import sys


def main(program: str, requirements: str) -> int:
    command = [program, "--requirement", requirements, "--require-hashes", "--disable-pip", "--format", "json"]
    done = subprocess.run([*command, "--progress-spinner", "off"], capture_output=True, text=True)
    try:
        found = json.loads(done.stdout)["dependencies"]
    except (ValueError, KeyError):
        reason = (done.stderr.strip().splitlines() or ["no answer"])[-1][:200]
        print(f"audit: no vulnerability database can be reached, nothing was audited ({reason})", file=sys.stderr)
        return 0
    known = [one for one in found if "skip_reason" not in one]
    if not known:
        print("audit: the vulnerability database answers for no package, nothing was audited", file=sys.stderr)
        return 0
    bad = [(one, each) for one in known for each in one["vulns"]]
    for one, each in bad:
        print(
            f"{one['name']} {one['version']}: {each['id']}, mended in {', '.join(each['fix_versions']) or 'no version'}"
        )
    print(f"audit: {len(known)} of {len(found)} packages audited, {len(bad)} known vulnerabilities")
    return 1 if bad else 0


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
