"""RLlib: two iterations of PPO; the prefix of the id lets remote runners import the package."""

from ray.rllib.algorithms.ppo import PPOConfig

config = (
    PPOConfig()
    .environment("prp_gym:PRP-Force-v0", env_config={"scenario": "randomized", "duration": 0.4})
    .env_runners(num_env_runners=1, rollout_fragment_length=400)
    .training(train_batch_size_per_learner=400, minibatch_size=100, num_epochs=1)
)
algorithm = config.build_algo()
for _ in range(2):
    print(algorithm.train()["env_runners"]["episode_return_mean"])
algorithm.stop()
