"""``sumo-cacc``: the study from the command line."""

import argparse
from pathlib import Path

from modelcast import PlatoonTrace
from sumo_cacc.figure import draw
from sumo_cacc.loop import Case, study

CASES = (("bsm-10hz", None), ("bsm-2hz", None), ("mbc", 0.02))


def main() -> None:
    """Drive all cases, print a line each, and draw their speeds."""
    parser = argparse.ArgumentParser(prog="sumo-cacc", description=__doc__)
    parser.add_argument("--vehicles", type=int, default=8, help="with the leader")
    parser.add_argument("--duration", type=float, default=60.0, help="seconds")
    parser.add_argument("--seeds", type=int, default=5, help="runs of each case")
    parser.add_argument("--loss", type=float, nargs="+", default=[0.0, 0.4], help="shares lost, 0..1")
    parser.add_argument("--out", type=Path, default=Path("sumo_cacc.png"), help="the figure")
    given = parser.parse_args()
    print("loss  sender     messages/s  least gap m  least time gap s  growth  collisions  age s")
    traces = dict[Case, PlatoonTrace]()
    for loss in given.loss:
        for sender, threshold_m in CASES:
            case = Case(sender, loss, threshold_m)
            row, traces[case] = study(
                case, vehicles=given.vehicles, duration_s=given.duration, seeds=given.seeds
            )
            print(
                f"{loss:4.0%}  {sender:9}  {row.rate_hz:10.2f}  {row.gap_min_m:11.2f}  "
                f"{row.time_gap_min_s:16.3f}  {row.growth:6.2f}  {row.collisions:4d} of {row.followers:<3d}  "
                f"{row.age_s:5.2f}"
            )
    draw(traces, given.out)
    print(f"figure: {given.out}")


if __name__ == "__main__":
    main()
