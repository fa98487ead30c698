/* Scores of whole episodes and their derivatives by the numbers of the controller: forward, with a tape of
   what the reverse sweep reads, then back. After compiled_period.c and the reverse functions of the physics.

   Source: Griewank 2008, 3.2. */

/* One period on the tape: what was given to its functions. */
typedef struct {
    double observation[PRP_OBSERVED], action[PRP_JOINTS], before[PRP_MEMORY + 1], between[PRP_MEMORY + 1];
    double command[PRP_JOINTS], saturated[PRP_JOINTS], torque[PRP_JOINTS], beyond[PRP_JOINTS];
    double clock, ended, reference[PRP_REFERENCE], measured[PRP_MEASURED];
} prp_period;

/* The tape of an episode: its periods, the controller's states before them, and the positions and velocities
   before each of their time steps and after the last. */
typedef struct {
    prp_period *periods;
    double *states, *motion;
} prp_tape;

/* The adjoints between two periods. */
typedef struct {
    double observation[PRP_OBSERVED], memory[PRP_MEMORY + 1], position[PRP_JOINTS], velocity[PRP_JOINTS];
    double state[PRP_LARGEST_STATE];
} prp_between;

/* Simulate one period on the tape; returns whether its action is finite. */
static inline int prp_tape_period(
    const prp_plan *plan, const prp_world *still, long row, long k, const prp_tape *tape)
{
    const size_t joints = sizeof(double) * PRP_JOINTS, memory = sizeof(double) * PRP_MEMORY;
    const long at = k * plan->rows + row, substeps = plan->world->substeps;
    prp_period *now = tape->periods + k;
    double *state = plan->state + plan->state_size * row, *action = plan->action + PRP_JOINTS * row;
    double *kept = tape->states + plan->state_size * k, *motion = tape->motion + 2 * PRP_JOINTS * (substeps + 1) * k;
    double *q = plan->position + PRP_JOINTS * row, *v = plan->velocity + PRP_JOINTS * row;
    memcpy(now->observation, plan->observation + PRP_OBSERVED * row, sizeof now->observation);
    memcpy(kept, state, sizeof(double) * plan->state_size);
    plan->controller(
        now->observation, kept, plan->input + plan->input_size * row,
        plan->controller_numbers + plan->numbers_size * row, action, state);
    if (!prp_finite(action, PRP_JOINTS))
        return 0;
    memcpy(now->action, action, joints);
    memcpy(now->before, plan->memory + PRP_MEMORY * row, memory);
    prp_before(plan, row, at);
    memcpy(now->between, plan->memory + PRP_MEMORY * row, memory);
    memcpy(now->command, plan->command + PRP_JOINTS * row, joints);
    memcpy(now->saturated, plan->saturated + PRP_JOINTS * row, joints);
    memcpy(now->torque, plan->torque + PRP_JOINTS * row, joints);
    for (long step = 0; step < substeps; step++, motion += 2 * PRP_JOINTS) {
        memcpy(motion, q, joints), memcpy(motion + PRP_JOINTS, v, joints);
        if (!plan->lost[row]) /* else it stays where it is, and the tape is complete all the same */
            plan->lost[row] = prp_substep(
                plan->world, q, v, now->torque, plan->plants + PRP_PLANT * row, plan->surfaces + PRP_SURFACE * row);
    }
    memcpy(motion, q, joints), memcpy(motion + PRP_JOINTS, v, joints);
    prp_advance(
        row, 1, NULL, still, plan->position, plan->velocity, plan->torque, plan->plants, plan->surfaces,
        plan->measured, plan->beyond, plan->lost);
    prp_after(plan, row, at);
    memcpy(now->reference, plan->reference + PRP_REFERENCE * row, sizeof now->reference);
    memcpy(now->measured, plan->measured + PRP_MEASURED * row, sizeof now->measured);
    memcpy(now->beyond, plan->beyond + PRP_JOINTS * row, joints);
    now->clock = plan->clock[row], now->ended = plan->lost[row];
    return 1;
}

/* Take the adjoints back through the time steps of one period; `d_torque` is replaced. */
static inline void prp_steps_back(
    const prp_plan *plan, long row, long k, const prp_tape *tape, const double *d_measured, prp_between *d,
    double *d_torque)
{
    const long substeps = plan->world->substeps;
    const double *plant = plan->plants + PRP_PLANT * row, *surface = plan->surfaces + PRP_SURFACE * row;
    const double *motion = tape->motion + 2 * PRP_JOINTS * ((substeps + 1) * k + substeps);
    const double *torque = tape->periods[k].torque;
    double d_q[PRP_JOINTS], d_v[PRP_JOINTS], d_tau[PRP_JOINTS];
    prp_measured_reverse(
        plan->world, motion, motion + PRP_JOINTS, torque, plant, surface, d_measured, d_q, d_v, d_torque);
    for (int j = 0; j < PRP_JOINTS; j++)
        d->position[j] += d_q[j], d->velocity[j] += d_v[j];
    for (long step = 0; step < substeps; step++) {
        motion -= 2 * PRP_JOINTS;
        prp_step_reverse(
            plan->world, motion, motion + PRP_JOINTS, torque, plant, surface, d->position, d->velocity, d_q, d_v,
            d_tau);
        memcpy(d->position, d_q, sizeof d_q), memcpy(d->velocity, d_v, sizeof d_v);
        for (int j = 0; j < PRP_JOINTS; j++)
            d_torque[j] += d_tau[j];
    }
}

/* Take the adjoints back through one period, and add those of the controller's numbers. */
static inline void prp_period_back(
    const prp_plan *plan, const prp_gradient *gradient, long row, long k, const prp_tape *tape, double *scratch,
    prp_between *d)
{
    static const double none[PRP_JOINTS > 3 ? PRP_JOINTS : 3];
    const prp_period *now = tape->periods + k;
    const long at = k * plan->rows + row;
    double d_measured[PRP_MEASURED], d_command[PRP_JOINTS], d_between[PRP_MEMORY + 1], d_torque[PRP_JOINTS];
    double d_action[PRP_JOINTS], d_state[PRP_LARGEST_STATE], *d_numbers = gradient->numbers + gradient->count * row;
    prp_judge_reverse(
        now->measured, now->reference, now->command, now->saturated, &now->clock, now->beyond, &now->ended,
        plan->error ? plan->error + 3 * at : none, now->between, plan->task_numbers, d->observation,
        &gradient->weight, d->memory, d_measured, d_command, d_between);
    prp_steps_back(plan, row, k, tape, d_measured, d, d_torque);
    prp_actuate_reverse(
        now->action, plan->noise ? plan->noise + PRP_JOINTS * at : none, now->before, plan->task_numbers, d_command,
        d_torque, d_between, d_action, d->memory);
    gradient->reverse(
        now->observation, tape->states + plan->state_size * k, plan->input + plan->input_size * row,
        plan->controller_numbers + plan->numbers_size * row, d_action, d->state, d->observation, d_state, scratch);
    memcpy(d->state, d_state, sizeof(double) * plan->state_size);
    for (long i = 0; i < gradient->count; i++)
        d_numbers[i] += scratch[i];
}

/* The score of one episode, on the tape. Returns its number of periods; negative where an action was not
   finite. */
static long prp_forward(
    const prp_plan *plan, const prp_gradient *gradient, const prp_world *still, long row, const prp_tape *tape)
{
    long k = 0;
    for (; k < plan->periods && !plan->lost[row]; k++) {
        if (!prp_tape_period(plan, still, row, k, tape))
            return -(k + 1);
        gradient->score[row] += gradient->weight * plan->reward[row];
    }
    return k;
}

/* Scores of some episodes, and their derivatives by the controller's numbers and its initial state. Returns
   whether there was enough memory.

   ended: see `prp_run`. */
int prp_differentiate(long first, long count, const prp_plan *plan, const prp_gradient *gradient)
{
    const long motion = 2 * PRP_JOINTS * (plan->world->substeps + 1);
    prp_tape tape = {
        malloc(sizeof(prp_period) * plan->periods), malloc(sizeof(double) * (plan->state_size + 1) * plan->periods),
        malloc(sizeof(double) * motion * plan->periods)};
    double *scratch = malloc(sizeof(double) * (gradient->count + 1));
    const int enough = tape.periods && tape.states && tape.motion && scratch;
    prp_world still = *plan->world;
    still.substeps = 0;
    for (long row = first; enough && row < first + count; row++) {
        const long periods = prp_forward(plan, gradient, &still, row, &tape);
        plan->ended[row] = periods < 0 || plan->lost[row] ? periods : 0;
        prp_between d;
        memset(&d, 0, sizeof d);
        for (long k = periods - 1; k >= 0; k--)
            prp_period_back(plan, gradient, row, k, &tape, scratch, &d);
        memcpy(gradient->state + plan->state_size * row, d.state, sizeof(double) * plan->state_size);
    }
    free(tape.periods), free(tape.states), free(tape.motion), free(scratch);
    return enough;
}
