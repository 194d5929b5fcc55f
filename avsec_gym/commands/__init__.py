"""The commands of `avsec`: one frozen dataclass each, which is configuration and CLI in one."""
