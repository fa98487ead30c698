"""SBX: SAC in JAX, on four environments that are stepped together."""

from sbx import SAC

import prp_gym

agent = SAC("MlpPolicy", prp_gym.make_sb3_vec_env("PRP-Force-v0", n_envs=4, seed=0), learning_starts=100)
agent.learn(400)
print(agent.num_timesteps)
