// Control of the fake haptic devices, from the process of a test.
//
// Each fake library has its vendor's symbols and, beside them, the functions below. They act on the
// one device of that library. Positions are in metres, forces in newtons, in the vendor's frame,
// whatever units the vendor's calls have. Functions may be called from any thread.
//
// hd   libHD.so, OpenHaptics HDAPI: x right, y up, z to the user
// dhd  libdhd.so, Force Dimension: x to the user, y right, z up
//
// They lie in build/release/fakes/<fake>. Their options are listed in the sources' comments, at
// `Defaults`; all have the resolution of what the vendor's calls report [m]. The handle follows the
// script of the simulated operator; without a script it rests.
//
// Programs are controlled through a socket: PALPATE_FAKE_<NAME>_CONTROL is its path. Each line sent
// gets one line back, "ok" or "error: ...". Lines: follow FILE.csv, which has the columns
// time_s,x,y,z, and press BUTTON DOWN [AFTER].
#pragma once

struct FakeKnot {
  double t;        // after `fake_follow` [s], rising
  double x, y, z;  // [m]
};

extern "C" {
// Restores the state after loading: real time, plugged in, at rest at the origin, default options,
// no script and no command.
void fake_reset();
// From now on the test controls the time: it is `now` [s], and only `fake_step` advances it. Servo
// threads are stopped; their callbacks run inside `fake_step`.
void fake_set_clock(double now);
void fake_step(double seconds);
double fake_now();

// 0, or -1: no such option, or not a value of it.
int fake_set_option(const char* name, const char* value);
// Puts the handle there, at rest [m].
void fake_place(double x, double y, double z);
// The operator's hand follows the knots, with minimum jerk between them, and holds at the last.
void fake_follow(const FakeKnot* knots, int count);
// Presses or releases a button, `after` seconds from now.
void fake_press(int button, int down, double after);

void fake_unplug();
void fake_replug();
// 0: runs. 1: answers repeat, commands have no effect, motors keep their force. 2: as 1, and the
// device's own thread makes no more calls.
void fake_freeze(int mode);
// The next `count` calls of the vendor's `function` ("": of any) fail with `code`; count < 0: all.
void fake_set_error(const char* function, int code, int count);

// Gets the present force of the motors. Returns 1 if they are on; 0: off, and f is zero.
int fake_last_force(double f[3]);
// Gets the force of the newest accepted command [N]. Returns its time [s].
double fake_last_command(double f[3]);
// How often the vendor's `function` was called.
int fake_calls(const char* function);
}
