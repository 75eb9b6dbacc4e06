"""One axis of a GRBL controller as ``drivers.polled_stage`` wants it."""

from typing import Final

from drivers.grbl.codec import HOME, JOG_CANCEL, SETTINGS, SOFT_RESET, Setting, jog_to, write_setting
from drivers.grbl.link import GrblLink
from drivers.grbl.settings import GrblSettings
from drivers.polled_stage import Status
from protocols import MotionProfile, PlanError

_MOVES: Final = frozenset({"Run", "Jog", "Home", "Hold1", "Door2", "Door3"})
"""States, with their sub-state where it matters, in which the axis moves."""

_WHOLE: Final = frozenset({"Run", "Jog", "Home", "Idle", "Alarm", "Check", "Sleep"})
"""States whose sub-state does not matter."""

_RESOLUTION_MM: Final = 0.001
"""Step of the position in a status line."""

_WCO_EVERY: Final = 31
"""The offset of work coordinates comes at the latest in every 30th status line."""

_RATE, _ACCELERATION = 110, 120
"""Settings of the X axis: highest rate in mm/min, acceleration in mm/s^2; Y and Z follow."""


class GrblAxis:
    """Satisfies ``drivers.polled_stage.Axis``: moves are jogs, since a jog can be cancelled and needs no reset after."""

    def __init__(self, link: GrblLink, settings: GrblSettings) -> None:
        self._link: Final = link
        self._settings: Final = settings
        self._offset_mm: float | None = None
        self._last_mm: float | None = None
        self._stored: dict[int, float] = {}

    @property
    def tolerance_mm(self) -> float:
        """See ``Axis``: the last digit of a position, and a step."""
        steps_per_mm = self._stored.get(100 + self._settings.axis_index, 1 / _RESOLUTION_MM)
        return _RESOLUTION_MM + 1 / steps_per_mm

    @property
    def stops(self) -> int:
        """See ``Axis``."""
        return self._link.wire.stops

    def read_settings(self) -> dict[int, float]:
        """Ask for all ``$`` settings of the controller, by number."""
        events = self._link.command(SETTINGS)
        self._stored = {event.number: event.value for event in events if isinstance(event, Setting)}
        return self._stored

    def find_offset(self) -> None:
        """Ask for the status until the position is known: where it comes in work coordinates, the offset comes seldom."""
        for _ in range(_WCO_EVERY):
            if self.status().mm is not None:
                return

    def status(self) -> Status:
        """See ``Axis``. While it homes, GRBL answers nothing, and nothing is asked."""
        link, clock = self._link, self._link.wire.clock
        link.pump()
        if link.homing:
            return Status(clock.now_s(), None, moving=True, homed=False, trouble="it homes, and is mute until it has")
        if link.silent:
            link.reset()  # it stands, waits for this, and is locked afterwards
        answer = link.status()
        report, index = answer.value, self._settings.axis_index
        if report.offset_mm is not None:
            self._offset_mm = report.offset_mm[index]
        if report.machine_mm is not None:
            self._last_mm = report.machine_mm[index]
        elif report.work_mm is not None and self._offset_mm is not None:
            self._last_mm = report.work_mm[index] + self._offset_mm
        state = report.state if report.state in _WHOLE else report.state + report.sub_state
        at_ease = report.state in {"Idle", "Run", "Jog", "Home"}
        return Status(
            time_s=answer.time_s,
            mm=self._last_mm,
            moving=state in _MOVES,
            homed=link.homed,
            trouble="" if at_ease else link.trouble or f"state {report.state}",
        )

    def check(self, profile: MotionProfile) -> None:
        """See ``Axis``: it starts from rest."""
        if profile.initial_velocity_mm_s:
            raise PlanError(
                device=self._link.wire.device,
                saw=f"a start velocity of {profile.initial_velocity_mm_s:g} mm/s",
                expected="0: the controller ramps up from rest",
                remedy="leave initial_velocity_mm_s out of plan.toml",
            )

    def runs(self, profile: MotionProfile) -> MotionProfile:
        """See ``Axis``: GRBL reckons in millimetres."""
        return profile

    def begin_move(self, target_mm: float, profile: MotionProfile, *, stops: int) -> None:
        """See ``Axis``."""
        link, number = self._link, _ACCELERATION + self._settings.axis_index
        if self._stored.get(number) != profile.acceleration_mm_s2:
            self._stored.pop(number, None)
            link.command(write_setting(number, profile.acceleration_mm_s2))
            self._stored[number] = profile.acceleration_mm_s2
        link.command(jog_to(self._settings.axis, target_mm, profile.velocity_mm_s), stops=stops)
        if link.wire.stops != stops:
            link.wire.put(JOG_CANCEL)  # the stop may have come before the jog had begun, and have been without effect

    def begin_home(self, profile: MotionProfile, *, stops: int) -> None:
        """See ``Axis``: at the controller's own rates; ``profile`` is not sent."""
        del profile
        self._link.begin_home(HOME, stops=stops)

    def send_stop(self) -> None:
        """See ``Axis``: a jog is cancelled; homing ends only by a reset, which loses the position."""
        self._link.wire.stop(SOFT_RESET if self._link.homing else JOG_CANCEL)

    def close(self) -> None:
        """See ``Axis``."""
        self._link.wire.close()
