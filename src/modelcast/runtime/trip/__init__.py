"""Stations driven by recorded trips, over a channel that loses messages."""
