/* A robot for telespring-link in C: a simulated handle behind the device protocol.
 *
 *     cc -O2 -Wall -Wextra -Werror -o device examples/device.c -lm
 *     ./device --listen 127.0.0.1:4600 --site 127.0.0.1:4601
 *
 * docs/device-protocol.md describes the rows. To join a robot of your own, replace `struct handle` and `move`.
 */

#define _POSIX_C_SOURCE 200809L

#include <errno.h>
#include <math.h>
#include <netdb.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>
#include <time.h>
#include <unistd.h>

#if defined(__BYTE_ORDER__) && __BYTE_ORDER__ != __ORDER_LITTLE_ENDIAN__
#error "the rows are little-endian: turn the eight bytes of each double round on this machine"
#endif
_Static_assert(sizeof(double) == 8, "a value of a row has 8 bytes");

enum {
    STATE_VALUES = 13,
    COMMAND_VALUES = 8,
    MOST_ROWS = 64, /* datagrams that one tick looks at */
};

static const double VERSION = 1.0;
static const double PERIOD = 0.001;  /* s, the sample period of the study */
static const double DEADLINE = 0.02; /* s, how long a command acts */
static const double LARGEST = 20.0;  /* N, the largest force that person and robot bear */
static const double PATIENCE = 5.0;  /* s without any command after the first one, after which this program ends */

/* A mass with a damper on each of two axes, held by a hand that follows a slow circle while the sides are coupled. */
struct handle {
    double position[2]; /* m */
    double velocity[2]; /* m/s */
    double seconds;     /* s, how long the hand has followed the circle; it rests at 0 otherwise */
};

/* Moves the handle for `span` s under the force of the motors, N; a robot of your own is told the force here. */
static void move(struct handle *handle, double span, const double force[2], int is_coupled) {
    double seconds = handle->seconds = is_coupled ? handle->seconds + span : 0.0;
    const double aim[2] = {0.03 * sin(seconds), 0.03 - 0.03 * cos(seconds)};
    for (int axis = 0; axis < 2; axis++) {
        double hand = 100.0 * (aim[axis] - handle->position[axis]) - 8.0 * handle->velocity[axis];
        handle->velocity[axis] += (force[axis] + hand - 8.0 * handle->velocity[axis]) / 1.0 * span;
        handle->position[axis] += handle->velocity[axis] * span;
    }
}

/* The monotonic clock, s. */
static double now(void) {
    struct timespec time;
    clock_gettime(CLOCK_MONOTONIC, &time);
    return (double)time.tv_sec + 1e-9 * (double)time.tv_nsec;
}

static void sleep_until(double seconds) {
    double rest = seconds - now();
    if (rest > 0.0) {
        struct timespec time = {.tv_sec = (time_t)rest, .tv_nsec = (long)(1e9 * (rest - floor(rest)))};
        nanosleep(&time, NULL);
    }
}

/* Ends the program with a message. */
static _Noreturn void fail(const char *what, const char *why) {
    fprintf(stderr, "%s: %s\n", what, why);
    exit(EXIT_FAILURE);
}

/* Finds the address "host:port". */
static struct addrinfo *find(const char *text) {
    char host[256];
    const char *colon = strrchr(text, ':');
    if (colon == NULL || (size_t)(colon - text) >= sizeof host) fail(text, "host:port is required");
    memcpy(host, text, (size_t)(colon - text));
    host[colon - text] = '\0';
    struct addrinfo *found, wanted = {.ai_family = AF_INET, .ai_socktype = SOCK_DGRAM};
    int error = getaddrinfo(host, colon + 1, &wanted, &found);
    if (error != 0) fail(text, gai_strerror(error));
    return found;
}

/* A socket that listens at one address and talks to the other only. */
static int open_link(const char *own, const char *site) {
    struct addrinfo *here = find(own), *there = find(site);
    int udp = socket(AF_INET, SOCK_DGRAM, 0);
    if (udp < 0 || bind(udp, here->ai_addr, here->ai_addrlen) != 0) fail(own, strerror(errno));
    if (connect(udp, there->ai_addr, there->ai_addrlen) != 0) fail(site, strerror(errno));
    freeaddrinfo(here);
    freeaddrinfo(there);
    return udp;
}

/* Takes the next command into `command`: 1 if there was one, 0 if no datagram is left, -1 for one that is no command. */
static int take(int udp, double command[COMMAND_VALUES]) {
    double room[COMMAND_VALUES + 1]; /* a longer datagram shows by its length */
    ssize_t length = recv(udp, room, sizeof room, MSG_DONTWAIT);
    if (length < 0) return errno == ECONNREFUSED ? -1 : 0; /* telespring-link does not listen yet, or nothing is left */
    if (length != (ssize_t)(8 * COMMAND_VALUES) || room[0] != VERSION) return -1;
    if (!isfinite(room[1]) || !isfinite(room[4]) || !isfinite(room[5])) return -1;
    memcpy(command, room, 8 * COMMAND_VALUES);
    return 1;
}

/* Cuts a force to the largest one, along its direction. */
static void limit(double force[2]) {
    double size = hypot(force[0], force[1]);
    for (int axis = 0; size > LARGEST && axis < 2; axis++) force[axis] *= LARGEST / size;
}

int main(int count, char **arguments) {
    const char *own = NULL, *site = NULL;
    for (int at = 1; at + 1 < count; at += 2) {
        if (strcmp(arguments[at], "--listen") == 0) own = arguments[at + 1];
        else if (strcmp(arguments[at], "--site") == 0) site = arguments[at + 1];
        else fail(arguments[at], "there is no such option");
    }
    if (count != 5 || own == NULL || site == NULL) fail("usage", "device --listen HOST:PORT --site HOST:PORT");
    int udp = open_link(own, site);

    struct handle handle = {{0.0, 0.0}, {0.0, 0.0}, 0.0};
    double force[2] = {0.0, 0.0}, newest = 0.0, commands = 0.0, largest = 0.0;
    double start = now(), moved = start, told = -INFINITY;
    double rows = 0.0;
    int is_coupled = 0;
    while (told == -INFINITY || now() - told < PATIENCE) {
        sleep_until(start + (rows + 1.0) * PERIOD);
        double tick = now(), command[COMMAND_VALUES];
        for (int looked = 0, taken = 1; taken != 0 && looked < MOST_ROWS; looked++) {
            taken = take(udp, command);
            if (taken < 1 || command[1] <= newest) continue;
            newest = command[1];
            commands += 1.0;
            force[0] = command[4];
            force[1] = command[5];
            limit(force);
            is_coupled = command[6] == 1.0;
            told = tick;
            if (command[7] == 1.0) { /* the session is over; command[6] is 0 in a pause, too */
                printf("%.0f rows, %.0f commands, %.3f N at most\n", rows, commands, largest);
                close(udp);
                return EXIT_SUCCESS;
            }
        }
        if (tick - told > DEADLINE) { /* nobody commands: let go */
            force[0] *= 0.9;
            force[1] *= 0.9;
            is_coupled = 0;
        }
        largest = fmax(largest, hypot(force[0], force[1]));
        move(&handle, fmin(tick - moved, 0.01), force, is_coupled);
        moved = tick;
        rows = fmax(rows + 1.0, floor((tick - start) / PERIOD)); /* a tick that was missed is left out */
        const double enabled = 1.0, homed = 1.0, stopped = 0.0;
        const double row[STATE_VALUES] = {
            VERSION, rows, tick - start, handle.position[0], handle.position[1], handle.velocity[0],
            handle.velocity[1], 0.0, 0.0, 0.0, enabled, homed, stopped,
        };
        (void)!send(udp, row, sizeof row, 0); /* fails while telespring-link does not listen */
    }
    fail("no command", "the robot is let go");
}
