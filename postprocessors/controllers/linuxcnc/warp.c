/*
 * A faster clock for LinuxCNC's servo thread: loaded with LD_PRELOAD, it lets CLOCK_MONOTONIC of rtapi_app run
 * HEXCITE_SPEEDUP times as fast as the wall clock, so that 1 ms servo cycles come every 1/HEXCITE_SPEEDUP ms.
 * The motion controller counts cycles and never looks at the wall clock: what it computes stays the same.
 *
 * Every other process of the session (the library is inherited by all of them) keeps the wall clock.
 */
#define _GNU_SOURCE
#include <dlfcn.h>
#include <errno.h>
#include <pthread.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#define NANOSECONDS_PER_SECOND 1000000000LL

typedef int (*gettime_function)(clockid_t, struct timespec *);
typedef int (*nanosleep_function)(clockid_t, int, const struct timespec *, struct timespec *);

static pthread_once_t prepared = PTHREAD_ONCE_INIT;
static gettime_function wall_gettime;
static nanosleep_function wall_nanosleep;
static int64_t origin; /* the instant at which both clocks agree, in ns */
static double speedup = 1.0;

static int64_t to_ns(const struct timespec *time)
{
    return time->tv_sec * NANOSECONDS_PER_SECOND + time->tv_nsec;
}

static struct timespec from_ns(int64_t ns)
{
    struct timespec time = {ns / NANOSECONDS_PER_SECOND, ns % NANOSECONDS_PER_SECOND};
    return time;
}

static void prepare(void)
{
    struct timespec now;
    const char *setting = getenv("HEXCITE_SPEEDUP");

    wall_gettime = (gettime_function)dlsym(RTLD_NEXT, "clock_gettime");
    wall_nanosleep = (nanosleep_function)dlsym(RTLD_NEXT, "clock_nanosleep");
    wall_gettime(CLOCK_MONOTONIC, &now);
    origin = to_ns(&now);
    if (setting && strcmp(program_invocation_short_name, "rtapi_app") == 0)
        speedup = atof(setting);
    if (!(speedup > 0.0))
        speedup = 1.0;
}

int clock_gettime(clockid_t clock, struct timespec *time)
{
    int result;

    pthread_once(&prepared, prepare);
    result = wall_gettime(clock, time);
    if (result == 0 && clock == CLOCK_MONOTONIC)
        *time = from_ns(origin + (int64_t)((to_ns(time) - origin) * speedup));
    return result;
}

int clock_nanosleep(clockid_t clock, int flags, const struct timespec *request, struct timespec *remaining)
{
    struct timespec wall;

    pthread_once(&prepared, prepare);
    if (clock != CLOCK_MONOTONIC || !(flags & TIMER_ABSTIME))
        return wall_nanosleep(clock, flags, request, remaining);
    wall = from_ns(origin + (int64_t)((to_ns(request) - origin) / speedup));
    return wall_nanosleep(clock, flags, &wall, remaining);
}
