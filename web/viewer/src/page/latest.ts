// Answers that arrive late: only the request that was begun last may change the page.

/**
 * Requests of one part of the page, of which the last one counts.
 *
 * The answer and the error of a request that was ended, or followed by another one, are dropped,
 * however far it has come. State that an answer is about changes with `end` or with another `ask`.
 */
export class Latest {
  private current: AbortController | null = null;

  /** Whether an answer is waited for. */
  get isAsking(): boolean {
    return this.current !== null;
  }

  /** Drop the answer that is waited for. */
  end(): void {
    this.current?.abort();
    this.current = null;
  }

  /**
   * Ask in place of the request before. `question` only fetches: what changes the page is in `show`
   * and `fail`, one of which is called if this request is still the last one.
   */
  async ask<Answer>(
    question: (signal: AbortSignal) => Promise<Answer>,
    show: (answer: Answer) => void,
    fail: (error: unknown) => void,
  ): Promise<void> {
    this.end();
    const asking = new AbortController();
    this.current = asking;
    let next: () => void;
    try {
      const answer = await question(asking.signal);
      next = () => show(answer);
    } catch (error) {
      next = () => fail(error);
    }
    if (this.current !== asking) return;
    this.current = null;
    next();
  }
}
