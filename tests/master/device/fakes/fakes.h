// Control of the fake haptic devices, from the process of a test.
//
// Each fake library has its vendor's symbols and, beside them, the functions below. They act on the
// one device of that library. Positions are in metres, forces in newtons, in the vendor's frame,
// whatever units the vendor's calls have. Functions may be called from any thread.
//
// | fake        | library                         | frame of the handle, and what force means
// | hd          | libHD.so, OpenHaptics HDAPI     | x right, y up, z to the user
// | dhd         | libdhd.so, Force Dimension      | x to the user, y right, z up; gravity acts
// along -z | spnav       | libspnav.so, SpaceMouse         | 2 mm are full deflection; makes no
// force | sdl         | libSDL2.so, one game controller | 10 mm are full deflection; force is {low,
// high} of 0..1
//
// They stand in build/release/fakes/<fake>, those that lack symbols in <fake>-missing, and older
// versions in <fake>-old. Their options are listed in the sources' comments, at `Defaults`.
//
// The handle is a point mass: m a = motors + operator + gravity - b v - c v/|v|, with stops at the
// ends of the workspace. Options of all libraries: mass [kg], viscosity b [N s/m], dry c [N],
// resolution of what the vendor's calls report [m], half_x, half_y, half_z of the workspace [m],
// grip_stiffness [N/m] (inf: the handle is where the operator's hand is) and grip_damping [N s/m]
// of a hand that follows a script.
//
// Programs are controlled by the environment. PALPATE_FAKE_<NAME>_COMMANDS holds lines of
// `fake_command` separated by ';', executed at loading. PALPATE_FAKE_<NAME>_CONTROL is the path of
// a socket that the library serves: each line sent gets one line back. NAME is HD, DHD, SPNAV or
// SDL.
#pragma once

struct FakeKnot {
  double t;        // after `fake_follow` [s], rising
  double x, y, z;  // [m]
};

struct FakeForce {
  double t;         // when the vendor's call gave it [s]
  double asked[7];  // force [N], torque [N m], force of the gripper [N]
  double made[3];   // what the motors make of it at that instant [N]
};

extern "C" {
// As after loading: real time, plugged in, at rest at the origin, default options, nothing scripted
// or logged.
void fake_reset();
// From now on time is what the test says: it is `now` [s], and only `fake_step` moves it. Servo
// threads rest; their callbacks run inside `fake_step`.
void fake_set_clock(double now);
void fake_step(double seconds);
double fake_now();

// 0, or -1: no such option, or not a value of it.
int fake_set_option(const char* name, const char* value);
// Puts the handle there, at rest [m].
void fake_place(double x, double y, double z);
// Turns the handle to the rotation vector [rad], where it has a wrist.
void fake_turn(double x, double y, double z);
// The operator's hand follows the knots, with minimum jerk between them, and holds at the last, or
// begins again. No knots: it lets go.
void fake_follow(const FakeKnot* knots, int count, int repeat);
// Presses or releases a button, `after` seconds from now.
void fake_press(int button, int down, double after);

void fake_unplug();
void fake_replug();
// 0: runs. 1: answers repeat, commands have no effect, motors keep their force. 2: as 1, and the
// device's own thread makes no calls any more.
void fake_freeze(int mode);
// The next `count` calls of the vendor's `function` ("": of any) fail with `code`; count < 0: all.
void fake_set_error(const char* function, int code, int count);

void fake_get_handle(double p[3], double v[3]);
// What the motors make now. 1: they are on; 0: off, f is zero.
int fake_last_force(double f[3]);
// The latest `room` entries, oldest first; how many.
int fake_force_log(FakeForce* log, int room);
// How often the vendor's `function` was called.
int fake_calls(const char* function);

// One line of text: set NAME VALUE | place X Y Z | turn X Y Z | follow FILE.csv [repeat] | release
// | press BUTTON DOWN [AFTER] | unplug | replug | freeze MODE | error FUNCTION CODE COUNT | clock
// NOW | step SECONDS | reset | force | handle | calls FUNCTION. FILE.csv has the columns
// time_s,x,y,z. `reply` gets "ok", what was asked for, or "error: ...". Returns 0 or -1.
int fake_command(const char* line, char* reply, int room);
}
