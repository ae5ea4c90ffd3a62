"""The played trip in the report: controls, map, errors over time, figures, and the data behind them.

Everything stays hidden until its script runs; without one the report's drawn figures show the same trip.
"""

from modelcast.core.cells import escape
from modelcast.report.playback import playback_caption, playback_document, playback_opening
from modelcast.report.scripts import data_block, static_text
from modelcast.study.result import EvaluationResult

__all__ = ["player", "player_css"]

_SPEEDS = ("0.25", "0.5", "1", "2", "5", "20")
_HEADS = ("receiver", "error", "last heard", "sub-model", "sent", "lost")


def player_css() -> str:
    """Return the style sheet of `player`."""
    return static_text("uPlot.min.css") + static_text("playback.css")


def player(result: EvaluationResult) -> str:
    """Return the played trip as markup; nothing where the evaluation holds none.

    Parameters
    ----------
    result
        The evaluation.
    """
    if result.playback is None:
        return ""
    values = playback_document(result)
    ratios = [one["packet_error_ratio"] for one in values["channels"]]
    first = ratios.index(max(ratios))
    channels = "".join(
        f'<option value="{at}"{" selected" if at == first else ""}>{_channel(ratio)}</option>'
        for at, ratio in enumerate(ratios)
    )
    speeds = "".join(
        f'<option value="{speed}"{" selected" if speed == "1" else ""}>&times;{speed}</option>'
        for speed in _SPEEDS
    )
    heads = "".join(f'<th class="text" scope="col">{head}</th>' for head in _HEADS)
    empty = '<td class="text"></td>' * (len(_HEADS) - 1)
    rows = "".join(
        f'<tr><th class="text" scope="row"><i></i>{escape(one["name"])}</th>{empty}</tr>'
        for one in values["senders"]
    )
    return f"""<section id="playback" aria-labelledby="playback-title" hidden>
<h2 id="playback-title">The trip, played</h2>
<p class="finding">{escape(playback_opening(result))}</p>
<div class="playback-row">
<button type="button" id="playback-play" aria-keyshortcuts="Space">Play</button>
<label class="long">Time <input type="range" id="playback-time" step="0.1"></label>
<output id="playback-now" for="playback-time"></output>
<label>Speed <select id="playback-speed">{speeds}</select></label>
<label>Channel <select id="playback-channel">{channels}</select></label>
</div>
<canvas id="playback-map" tabindex="0" role="application" aria-label="Map of the trip"
 aria-description="Arrow keys move it, plus and minus zoom, 0 shows all, Space plays."></canvas>
<div class="playback-row" role="group" aria-label="Map">
<button type="button" id="playback-follow" aria-pressed="true">Follow</button>
<button type="button" id="playback-map-in" aria-label="Map: zoom in">+</button>
<button type="button" id="playback-map-out" aria-label="Map: zoom out">&minus;</button>
<button type="button" id="playback-map-all" aria-label="Map: whole trip">Whole trip</button>
</div>
<p id="playback-when"></p>
<div class="wide"><table id="playback-figures">
<thead><tr>{heads}</tr></thead><tbody>{rows}</tbody></table></div>
<div id="playback-timeline" tabindex="0" role="application" aria-label="Errors and messages over time"
 aria-description="Left and right change the time, plus and minus zoom, 0 shows all, Space plays."></div>
<div class="playback-row" role="group" aria-label="Errors over time">
<button type="button" id="playback-time-in" aria-label="Time: zoom in">+</button>
<button type="button" id="playback-time-out" aria-label="Time: zoom out">&minus;</button>
<button type="button" id="playback-time-all" aria-label="Time: whole trip">Whole trip</button>
</div>
<p class="note">{escape(playback_caption(result))}</p>
</section>
{data_block("playback-data", values)}"""


def _channel(ratio: float) -> str:
    return f"{100 * ratio:.4g} % lost" if ratio > 0.0 else "nothing lost"
