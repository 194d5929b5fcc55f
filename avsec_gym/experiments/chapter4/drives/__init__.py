"""The test over frames: what adds up over ten successive instants of a drive."""
