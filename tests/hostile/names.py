"""Names that a terminal, or what prints to it, could take for something else."""

NAMES = [
    "x[/b]",
    "a[bold]",
    "a[link=file:///etc]b",
    "run:cat:",
    "back\\[red]slash\\",
    "{task.description}",
    "100%s",
    "clear\x1b[2J\x1b]0;title\x07",
    "c1\x9b2J",
    "turned\u202egnp",
]
"""Stems of files: markup, emoji and escapes."""

STEERING = {chr(code) for code in (*range(9), *range(11, 32), *range(127, 160), 0x202E)}
"""What must not reach a terminal from a name."""
