"""What the report of a reproduction says in words: the paper in short, and how its tables are to be read."""

__all__ = ["CAPTIONS", "INTRODUCTION", "READING_NOTE", "TITLES", "WHY_THEY_DIFFER"]

INTRODUCTION = (
    (
        "Mahjoub, Toghi, Gani and Fallah (2019) let a vehicle broadcast a model of its motion "
        "instead of its state. The vehicle holds two sub-models: constant velocity, and two "
        "Gaussian processes, of its east and of its north position against time, with a linear "
        "and an RBF kernel, fitted to the last ten samples. Receivers predict with the one that "
        "was named last. At every new position the vehicle looks at what each sub-model fitted at"
        " the last update predicted. While the smallest error stays under a threshold, nothing is"
        " fitted; where the one in use fails and another holds, a short identification names it; "
        "where all have failed, all are fitted anew and a model update is sent."
    ),
    (
        "The baseline is the same rule with a plain basic safety message, whose receiver "
        "extrapolates at constant velocity. The paper compares message rates at thresholds of 20 "
        "to 50 cm, and tracking under packet loss at equal rates. It was evaluated on one trip of"
        " the Safety Pilot Model Deployment."
    ),
    (
        "Sentences below are the paper's in our words. Every choice is run by itself, the others "
        "plain: what the paper leaves open, and, where it does say, the other option too. Four "
        "more readings combine what by itself gave the fewest or the most messages, or the best "
        "or the worst tracking, on these very trips, among the open choices alone. They show how "
        "far apart readings of one text may lie; choices do not add up, so a combination need not"
        " be an end."
    ),
)

READING_NOTE = (
    "Ratios are to the baseline at rising thresholds; in brackets 95 % bootstrap intervals over "
    "the trips. Where there is one trip, messages have none, and errors have Student-t intervals "
    "over the seeds of the losses. A claim holds where every interval lies below 1, fails where "
    "every one lies above, is not shown where none lies to one side, and holds in part otherwise."
    " Without intervals the ratios themselves decide."
    " What stands beside the claims is held against a free receiver: plain messages that are "
    "coasted by the shipped profile's best sub-model of what they say anyway (`--bank free`; "
    "`ctra` where the profile has none), which may have learnt from these very trips."
)

WHY_THEY_DIFFER = (
    "Why readings differ: updates come when all sub-models have failed, whoever is in use; the "
    "start rule, the identification rule and the order of the bank decide how many "
    "identifications come on top, and an identification counts as a message. With constant "
    "velocity in use first, each update whose constant velocity fails early is followed by one; "
    "the rule `best` names every change of the smallest error. The noise floor, a sensor's noise "
    "and the source of the velocity change the sub-models themselves: where the log is clean, a "
    "process without a floor may follow its last samples exactly and bend with them, and a floor "
    "makes it straighter; behind a sensor it extrapolates the noise. The rate basis decides whom "
    "the hybrid is held against under loss: a baseline at the rate of updates has fewer messages "
    "than MBC sends in all, by the identifications, so it falls behind; at the rate of all "
    "messages it has as many. A keep-alive bounds how long a lost message goes unnoticed, for MBC"
    " and for the error-driven baseline."
)

TITLES = {
    "system": "The system",
    "algorithm": "Algorithm 1",
    "message_rate": "Message rate against the threshold",
    "distribution_update": ("Distribution of the error, baseline at the rate of updates (the paper's basis)"),
    "distribution_total": ("Distribution of the error, baseline at the rate of all messages"),
    "loss_update": (
        "90th percentile against packet loss, baseline at the rate of updates (the paper's basis)"
    ),
    "loss_total": ("90th percentile against packet loss, baseline at the rate of all messages"),
    "sub_models": "One sub-model holds while the other fails",
    "manoeuvre": "A manoeuvre",
    "readings": "What every open choice does",
}
"""Headings of the figures, by the stem of their files, in the order of the report."""

CAPTIONS = {
    "system": (
        "From a measurement to the host's belief. Small letters name the part of modelcast that "
        "does it; they are asked of the code itself."
    ),
    "algorithm": (
        "What is decided at every new position, with the rules that the paper leaves open where they act."
    ),
    "readings": (
        "One row a reading, one marker a threshold; lines are 95 % intervals. Left of the dotted "
        "line the hybrid sends fewer messages, or tracks better. The plain reading is the first "
        "row; each of the others differs from it in one choice, but for the combinations at the "
        "bottom. Hollow markers: the same over plain messages that receivers coast by speed, "
        "heading, acceleration and yaw rate, without intervals."
    ),
    "sub_models": (
        "The stretch of 30 s in which each sub-model holds longest while the other fails. Error "
        "of both since the last update, before the instant's message and without loss; below, "
        "strips are coloured while a sub-model stays under the threshold and grey while it fails."
    ),
    "manoeuvre": (
        "The manoeuvre of 10 m of way or more in which the two paths part the most, of those to a"
        " side if there are any: the true path, and the ones predicted from half a second before "
        "it; a cross marks where the error first reaches the threshold."
    ),
}
"""Captions of the figures that only a reproduction has, or draws otherwise."""
